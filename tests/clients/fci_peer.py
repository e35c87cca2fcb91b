#!/usr/bin/env python3
"""An independent peer of the Franka Control Interface, protocol 5 (arm 1337, hand 1338), for tests of clients. No physics: commands
become the state.

It shares nothing with the code under test. Unmodified programs of libfranka 0.9.2, panda-python 1.1.1 and libfranka-rs 0.9.0 have run
against it. Options provoke a reflex, a user stop, another version, FIN or RST, silence; --strict drops late commands and aborts after 20
lost ones. With --port 0 it finds two free ports itself. "listening PORT" on stdout says that it is ready.
"""
import socket,struct,threading,time,re,math,sys,os,argparse,select
ap=argparse.ArgumentParser()
ap.add_argument('--reflex-at',type=int,default=0); ap.add_argument('--reflex-idx',type=int,default=7)
ap.add_argument('--strict',action='store_true'); ap.add_argument('--stop-status',type=int,default=0)
ap.add_argument('--version',type=int,default=5); ap.add_argument('--model',default='',help='shared object to serve')
ap.add_argument('--host',default='127.0.0.1'); ap.add_argument('--port',type=int,default=1337,help='arm; the hand listens on port+1; 0: any two')
ap.add_argument('--userstop-at',type=int,default=0); ap.add_argument('--close-at',default='')  # 'fin'|'rst' at first Set*
ap.add_argument('--mute-udp',action='store_true'); ap.add_argument('-v',action='store_true')
A=ap.parse_args()
# field type count offset: FCI protocol 5, robot state, robot command, gripper state
ROBOT_STATE = '''
message_id u64 1 0; O_T_EE f64 16 8; O_T_EE_d f64 16 136; F_T_EE f64 16 264; EE_T_K f64 16 392; F_T_NE f64 16 520;
NE_T_EE f64 16 648; m_ee f64 1 776; I_ee f64 9 784; F_x_Cee f64 3 856; m_load f64 1 880; I_load f64 9 888; F_x_Cload f64 3 960;
elbow f64 2 984; elbow_d f64 2 1000; tau_J f64 7 1016; tau_J_d f64 7 1072; dtau_J f64 7 1128; q f64 7 1184; q_d f64 7 1240;
dq f64 7 1296; dq_d f64 7 1352; ddq_d f64 7 1408; joint_contact f64 7 1464; cartesian_contact f64 6 1520;
joint_collision f64 7 1568; cartesian_collision f64 6 1624; tau_ext_hat_filtered f64 7 1672; O_F_ext_hat_K f64 6 1728;
K_F_ext_hat_K f64 6 1776; O_dP_EE_d f64 6 1824; O_ddP_O f64 3 1872; elbow_c f64 2 1896; delbow_c f64 2 1912;
ddelbow_c f64 2 1928; O_T_EE_c f64 16 1944; O_dP_EE_c f64 6 2072; O_ddP_EE_c f64 6 2120; theta f64 7 2168; dtheta f64 7 2224;
motion_generator_mode u8 1 2280; controller_mode u8 1 2281; errors bool 41 2282; reflex_reason bool 41 2323;
robot_mode u8 1 2364; control_command_success_rate f64 1 2365'''
ROBOT_COMMAND = '''
message_id u64 1 0; q_c f64 7 8; dq_c f64 7 64; O_T_EE_c f64 16 120; O_dP_EE_c f64 6 248; elbow_c f64 2 296;
valid_elbow bool 1 312; motion_generation_finished bool 1 313; tau_J_d f64 7 314'''
GRIPPER_STATE = '''
message_id u32 1 0; width f64 1 4; max_width f64 1 12; is_grasped bool 1 20; temperature u16 1 21'''
FMT={'u64':'Q','u32':'I','u16':'H','u8':'B','bool':'B','f64':'d'}
def table(text):
    rows=(r.split() for r in text.replace('\n',' ').split(';') if r.strip())
    return {n:(FMT[t],int(c),int(o)) for n,t,c,o in rows}
ST=table(ROBOT_STATE); CM=table(ROBOT_COMMAND); GS=table(GRIPPER_STATE)
def pack(tab,size,d):
    b=bytearray(size)
    for n,v in d.items():
        f,c,o=tab[n]
        if c==1: struct.pack_into('<'+f,b,o,v)
        else: struct.pack_into('<%d%s'%(c,f),b,o,*v)
    return bytes(b)
def unpack(tab,b):
    d={}
    for n,(f,c,o) in tab.items():
        v=struct.unpack_from('<%d%s'%(c,f),b,o); d[n]=v[0] if c==1 else list(v)
    return d
# ---- kinematics: the DH parameters of Franka's documentation
DH=[(0,.333,0),(0,0,-math.pi/2),(0,.316,math.pi/2),(.0825,0,math.pi/2),(-.0825,.384,-math.pi/2),(0,0,math.pi/2),(.088,0,math.pi/2),(0,.107,0)]
def mm(a,b): return [[sum(a[i][k]*b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]
def cm(T): return [T[r][c] for c in range(4) for r in range(4)]
def rm(v): return [[v[4*c+r] for c in range(4)] for r in range(4)]
def fk(q,F_T_EE):
    T=[[float(i==j) for j in range(4)] for i in range(4)]
    for i,(a,d,al) in enumerate(DH):
        th=q[i] if i<7 else 0.; ca,sa,ct,st=math.cos(al),math.sin(al),math.cos(th),math.sin(th)
        T=mm(T,[[ct,-st,0,a],[st*ca,ct*ca,-sa,-sa*d],[st*sa,ct*sa,ca,ca*d],[0,0,0,1]])
    T=mm(T,rm(F_T_EE)); T[3]=[0.,0.,0.,1.]
    return cm(T)
c45=math.sqrt(.5); I16=[1.,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]
QF=-0.467002423653011
class Robot:
    def __init__(s):
        q=[0,-math.pi/4,0,-3*math.pi/4+.2,0,math.pi/2,math.pi/4]
        s.x={k:([0.]*c if c>1 else 0) for k,(f,c,o) in ST.items()}
        x=s.x; x['errors']=[0]*41; x['reflex_reason']=[0]*41
        x['F_T_NE']=[c45,-c45,0,0,c45,c45,0,0,0,0,1,0,0,0,.1034,1]; x['NE_T_EE']=I16; x['EE_T_K']=I16; x['F_T_EE']=x['F_T_NE']
        x['m_ee']=.73; x['F_x_Cee']=[-.01,0,.03]; x['I_ee']=[.001,0,0,0,.0025,0,0,0,.0017]; x['O_ddP_O']=[0,0,-9.81]
        x['q']=list(q); x['q_d']=list(q); x['theta']=list(q); x['message_id']=1000; x['robot_mode']=1; x['controller_mode']=3
        s.rest(); s.move=None; s.run=None; s.epoch=0; s.hist=[]; s.nlost=0; s.cyc=0
    def rest(s):
        x=s.x
        for k in ('dq','dq_d','ddq_d','O_dP_EE_c','O_ddP_EE_c','O_dP_EE_d','delbow_c','ddelbow_c','tau_J_d'): x[k]=[0.]*len(x[k])
        s.kin(); x['O_T_EE_c']=x['O_T_EE']; x['elbow_c']=x['elbow']
    def kin(s):
        x=s.x; x['O_T_EE']=x['O_T_EE_d']=fk(x['q'],x['F_T_EE'])
        sg=(x['q'][3]>QF)-(x['q'][3]<QF); x['elbow']=x['elbow_d']=[x['q'][2],float(sg)]
R=Robot()
lock=threading.RLock()
class Client: pass
cl=None
def tsend(c,b):
    with c.tl: c.s.sendall(b)
def resp(c,cmd,cid,status,extra=b''): tsend(c,struct.pack('<IIIB',cmd,cid,13+len(extra),status)+extra)
def log(*a):
    if A.v: print(*a,flush=True)
stats={'cmd':0,'late':0,'stale':0,'lost':0,'maxgap':0}
def leave(mode,status):
    "leave motion: called with lock"
    x=R.x; x['motion_generator_mode']=0; x['controller_mode']=3; x['robot_mode']=mode; x['control_command_success_rate']=0.
    cid=R.move; R.move=None; R.run=None; R.rest()
    if cid is not None: resp(cl,1,cid,status)
def reflex(i):
    R.x['errors'][i]=1; R.x['reflex_reason'][i]=1; log('REFLEX',i); leave(4,6)
def apply(c):
    x=R.x; mg=x['motion_generator_mode']; dt=1e-3
    if mg==1:
        v=[(a-b)/dt for a,b in zip(c['q_c'],x['q_d'])]; x['ddq_d']=[(a-b)/dt for a,b in zip(v,x['dq_d'])]; x['dq_d']=v; x['q_d']=list(c['q_c'])
    elif mg==2:
        x['ddq_d']=[(a-b)/dt for a,b in zip(c['dq_c'],x['dq_d'])]; x['dq_d']=list(c['dq_c']); x['q_d']=[a+b*dt for a,b in zip(x['q_d'],c['dq_c'])]
    elif mg==3:
        v=[(c['O_T_EE_c'][12+i]-x['O_T_EE_c'][12+i])/dt for i in range(3)]+[0.]*3
        x['O_ddP_EE_c']=[(a-b)/dt for a,b in zip(v,x['O_dP_EE_c'])]; x['O_dP_EE_c']=v; x['O_T_EE_c']=list(c['O_T_EE_c'])
    elif mg==4:
        x['O_ddP_EE_c']=[(a-b)/dt for a,b in zip(c['O_dP_EE_c'],x['O_dP_EE_c'])]; x['O_dP_EE_c']=list(c['O_dP_EE_c'])
    if mg in(3,4) and c['valid_elbow']:
        v=(c['elbow_c'][0]-x['elbow_c'][0])/dt; x['ddelbow_c']=[(v-x['delbow_c'][0])/dt,0.]; x['delbow_c']=[v,0.]; x['elbow_c']=list(c['elbow_c'])
    if x['controller_mode']==2: x['tau_J_d']=list(c['tau_J_d'])
    if x['controller_mode']!=2 and mg in(1,2): x['q']=x['theta']=list(x['q_d']); x['dq']=list(x['dq_d'])
    R.kin()
def loop():
    nxt=time.monotonic()
    while True:
        nxt+=1e-3
        with lock:
            c=cl; x=R.x; x['message_id']+=1; k=x['message_id']
            if R.move is not None and R.run is None and R.starting:
                R.starting-=1
                if R.starting==0:
                    ctrl,mg=R.req; R.rest(); x['reflex_reason']=[0]*41
                    x['motion_generator_mode']=mg+1; x['controller_mode']=ctrl; x['robot_mode']=2; R.run=0; R.first=False; R.epoch=k; R.hist=[]; R.nlost=0
            st=pack(ST,2373,x) if c else None
        if c and not A.mute_udp:
            try: c.u.sendto(st,(c.addr,c.port))
            except OSError: pass
        got=None
        while True:
            to=nxt-time.monotonic()
            if to<=0: break
            if c is None: time.sleep(to); break
            r,_,_=select.select([c.u],[],[],max(0,to))
            if not r: break
            try: b=c.u.recv(4096)
            except OSError: break
            if len(b)!=370: print('BAD CMD SIZE',len(b)); continue
            d=unpack(CM,b); stats['cmd']+=1
            if d['message_id']!=k:
                stats['late']+=1
                if A.strict: continue
            if d['message_id']<R.epoch or R.run is None: stats['stale']+=1; continue
            got=d
            if got: continue
        if time.monotonic()-nxt>.005: nxt=time.monotonic()
        with lock:
            if R.run is not None and c is cl:
                R.run+=1
                if got: R.first=True
                if R.first:
                    R.hist=(R.hist+[1 if got else 0])[-100:]; R.nlost=0 if got else R.nlost+1
                    stats['maxgap']=max(stats['maxgap'],R.nlost); stats['lost']+=0 if got else 1
                    R.x['control_command_success_rate']=sum(R.hist)/len(R.hist)
                if got:
                    apply(got)
                    if got['motion_generation_finished']: log('finished',R.run,'cycles',stats); leave(1,0); continue
                elif R.first and A.strict:
                    if R.nlost>=20: reflex(25); continue
                if A.reflex_at and R.run>=A.reflex_at: reflex(A.reflex_idx); continue
                if A.userstop_at and R.run>=A.userstop_at: leave(5,7); continue
NAMES=['Connect','Move','StopMove','GetCartesianLimit','SetCollisionBehavior','SetJointImpedance','SetCartesianImpedance','SetGuidingMode','SetEEToK','SetNEToEE','SetLoad','SetFilters','AutomaticErrorRecovery','LoadModelLibrary']
PAY=[4,56,0,4,416,56,48,7,128,128,104,40,0,2]
def rx(s,n):
    b=b''
    while len(b)<n:
        t=s.recv(n-len(b))
        if not t: raise ConnectionError
        b+=t
    return b
def robot_client(s,addr):
    global cl
    c=Client(); c.s=s; c.addr=addr[0]; c.tl=threading.Lock(); c.u=socket.socket(socket.AF_INET,socket.SOCK_DGRAM); c.u.bind((A.host,0)); c.port=None
    s.setsockopt(socket.IPPROTO_TCP,socket.TCP_NODELAY,1)
    try:
        while True:
            cmd,cid,size=struct.unpack('<III',rx(s,12)); p=rx(s,size-12)
            assert len(p)==PAY[cmd],(NAMES[cmd],len(p))
            log('<-',NAMES[cmd],cid)
            if cmd==0:
                v,c.port=struct.unpack('<HH',p)
                if v!=A.version: tsend(c,struct.pack('<IIIBH',0,cid,15,1,A.version)); continue
                tsend(c,struct.pack('<IIIBH',0,cid,15,0,5))
                with lock: cl=c
            elif cmd==1:
                ctrl,mg=struct.unpack_from('<II',p); dev=struct.unpack_from('<6d',p,8); log('  ctrl',ctrl,'mg',mg,dev)
                with lock:
                    if R.x['robot_mode']!=1 or R.move is not None: resp(c,1,cid,3)
                    else:
                        R.req=(ctrl,mg); R.move=cid; R.starting=3; resp(c,1,cid,1)
            elif cmd==2:
                with lock:
                    if R.run is not None: resp(c,2,cid,0); leave(1,2)
                    else: resp(c,2,cid,A.stop_status)
            elif cmd==3: resp(c,3,cid,0,struct.pack('<3d16d?',1,2,3,*I16,True))
            elif cmd in range(4,12):
                if A.close_at=='fin': s.shutdown(socket.SHUT_RDWR); s.close(); return
                if A.close_at=='rst': s.setsockopt(socket.SOL_SOCKET,socket.SO_LINGER,struct.pack('ii',1,0)); s.close(); return
                with lock:
                    if R.run is not None: resp(c,cmd,cid,1); continue
                    x=R.x
                    if cmd==8: x['EE_T_K']=list(struct.unpack('<16d',p))
                    if cmd==9: x['NE_T_EE']=list(struct.unpack('<16d',p)); x['F_T_EE']=cm(mm(rm(x['F_T_NE']),rm(x['NE_T_EE']))); R.rest()
                    if cmd==10: v=struct.unpack('<13d',p); x['m_load']=v[0]; x['F_x_Cload']=list(v[1:4]); x['I_load']=list(v[4:])
                    resp(c,cmd,cid,0)
            elif cmd==12:
                with lock: R.x['errors']=[0]*41; R.x['robot_mode']=1; resp(c,12,cid,0)
            elif cmd==13:
                a,sy=p; log('  arch',a,'system',sy)
                if (a,sy)==(0,0) and os.path.exists(A.model): resp(c,13,cid,0,open(A.model,'rb').read())
                else: resp(c,13,cid,1)
    except (ConnectionError,OSError) as e: log('client gone',repr(e),stats)
    finally:
        with lock:
            if cl is c: cl=None; R.move=None; R.run=None; R.x['motion_generator_mode']=0; R.x['controller_mode']=3; R.x['robot_mode']=1; R.rest()
        try: s.close()
        except OSError: pass
# ---- gripper
G={'message_id':0,'width':.05,'max_width':0.,'is_grasped':0,'temperature':30}
def gripper_client(s,addr):
    u=socket.socket(socket.AF_INET,socket.SOCK_DGRAM); alive=[True]
    def stream(port):
        while alive[0]:
            G['message_id']+=20; u.sendto(pack(GS,23,G),(addr[0],port)); time.sleep(.02)
    try:
        while True:
            cmd,cid,size=struct.unpack('<HII',rx(s,10)); p=rx(s,size-10); log('<- gripper',cmd,cid,len(p)); assert len(p)==[4,0,40,16,0][cmd]
            if cmd==0:
                v,port=struct.unpack('<HH',p); ok=v==3; s.sendall(struct.pack('<HIIHH',0,cid,14,0 if ok else 1,3)); threading.Thread(target=stream,args=(port,),daemon=True).start(); continue
            time.sleep(.3)
            if cmd==1: G.update(width=.08,max_width=.08,is_grasped=0); r=0
            if cmd==2:
                w,ei,eo,sp,f=struct.unpack('<5d',p); d=.03; G.update(width=d,is_grasped=int(w-ei<d<w+eo)); r=0 if G['is_grasped'] else 2; log('  grasp',w,ei,eo,sp,f)
            if cmd==3: w,sp=struct.unpack('<2d',p); G.update(width=w,is_grasped=0); r=0
            if cmd==4: G.update(is_grasped=0); r=0
            s.sendall(struct.pack('<HIIH',cmd,cid,12,r))
    except (ConnectionError,OSError): pass
    finally: alive[0]=False; s.close()
def listener(port):
    l=socket.socket(); l.setsockopt(socket.SOL_SOCKET,socket.SO_REUSEADDR,1); l.bind((A.host,port)); l.listen(4); return l
def serve(l,f):
    while True:
        s,a=l.accept(); threading.Thread(target=f,args=(s,a),daemon=True).start()
sys.setswitchinterval(1e-4)
def pair():
    if A.port: return listener(A.port),listener(A.port+1)  # a taken port ends the program here
    while True:
        arm=listener(0)
        try: return arm,listener(arm.getsockname()[1]+1)
        except (OSError,OverflowError): arm.close()
arm,hand=pair()
print('listening',arm.getsockname()[1],flush=True)
threading.Thread(target=serve,args=(arm,robot_client),daemon=True).start()
threading.Thread(target=serve,args=(hand,gripper_client),daemon=True).start()
loop()
